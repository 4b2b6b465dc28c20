rule fracture:
    input:
        unpack(lambda wildcards: CAMPAIGN.last_front(wildcards.case, wildcards.inc)),
        crack=f"{INC}/crack.vtp",
        volume=f"{INC}/volume.vtu",
        labels=f"{CASE}/labels.npz",
        files=given("fracture"),
        solution=f"{INC}/solution.npz",
    output:
        sif=f"{INC}/sif.csv",
        report=f"{INC}/fracture.json",
    log:
        f"{LOG}/{{inc}}/fracture.log",
    priority: in_turn(0.5)  # the next increment waits for it
    group:
        "field_{case}_{inc}"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=job_memory("fracture", f"{INC}/volume.vtu"),
        runtime=job_minutes("fracture", f"{INC}/volume.vtu"),
    params:
        costs=f"{BENCHMARK}/{{inc}}/fracture.tsv",
        model=lambda wildcards: CAMPAIGN.model_flags(wildcards.case),
        options=lambda wildcards: CAMPAIGN.flags("fracture", wildcards.case),
        growth=lambda wildcards: CAMPAIGN.growth_flags(wildcards.case),
        units=lambda wildcards: CAMPAIGN.unit_flags(wildcards.case),
        last=lambda wildcards, input: command_flags(
            {key: input.get(key) for key in ("last", "last_growth")}
        ),
        content=content("fracture"),
        code=CAMPAIGN.code("fracture"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh fracture {input.volume:q} {input.solution:q} --crack {input.crack:q}"
        " --microstructure {input.labels:q} {params.model} {params.options} {params.growth}"
        " {params.units} {params.last} -o {output.sif:q} --json {output.report:q} > {log:q} 2>&1"
