rule solve:
    input:
        volume=f"{INC}/volume.vtu",
        labels=f"{CASE}/labels.npz",
        files=given("solve"),
    output:
        solution=f"{INC}/solution.npz",
        view=f"{INC}/solution.vtu",
    log:
        f"{LOG}/{{inc}}/solution.log",
    priority: in_turn(0.5)  # the next increment waits for it
    group:
        "field_{case}_{inc}"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=job_memory("solve", f"{INC}/volume.vtu"),
        runtime=job_minutes("solve", f"{INC}/volume.vtu"),
    params:
        costs=f"{BENCHMARK}/{{inc}}/solution.tsv",
        model=lambda wildcards: CAMPAIGN.solved_flags(wildcards.case),
        options=lambda wildcards: CAMPAIGN.flags("solve", wildcards.case),
        content=content("solve"),
        code=CAMPAIGN.code("solve"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh solve {input.volume:q} --microstructure {input.labels:q} {params.model} {params.options}"
        " -o {output.solution:q} --vtu {output.view:q} > {log:q} 2>&1"
