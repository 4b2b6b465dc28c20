rule inp:
    input:
        volume=f"{INC}/volume.vtu",
        labels=f"{CASE}/labels.npz",
        files=given("inp"),
    output:
        model=f"{INC}/model.inp",
        mesh=CAMPAIGN.deck_files(f"{INC}/model.inp")[1:],
    log:
        f"{LOG}/{{inc}}/model.log",
    priority: in_turn()
    group:
        "deck_{case}_{inc}"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=job_memory("inp", f"{INC}/gradated.vtp"),
        runtime=job_minutes("inp", f"{INC}/gradated.vtp"),
    params:
        costs=f"{BENCHMARK}/{{inc}}/model.tsv",
        options=lambda wildcards: CAMPAIGN.deck_flags(wildcards.case),
        content=content("inp"),
        code=CAMPAIGN.code("inp"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh inp {input.volume:q} --microstructure {input.labels:q} {params.options} -o {output.model:q}"
        " > {log:q} 2>&1"


rule export:
    input:
        volume=f"{INC}/volume.vtu",
        labels=f"{CASE}/labels.npz",
        sizing=f"{INC}/sizing.npz",
    output:
        f"{INC}/model.{{kind}}",
    log:
        f"{LOG}/{{inc}}/model.{{kind}}.log",
    wildcard_constraints:
        kind=CAMPAIGN.export_kinds,
    priority: in_turn()
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=job_memory("export", f"{INC}/volume.vtu"),
        runtime=job_minutes("export", f"{INC}/volume.vtu"),
    params:
        costs=f"{BENCHMARK}/{{inc}}/model.{{kind}}.tsv",
        options=lambda wildcards: CAMPAIGN.export_flags(wildcards.case),
        code=CAMPAIGN.code("export"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh export {input.volume:q} --microstructure {input.labels:q} --sizing {input.sizing:q}"
        " {params.options} -o {output:q} > {log:q} 2>&1"


rule check:
    input:
        volume=f"{INC}/volume.vtu",
        meshing=f"{INC}/meshing.json",
        labels=f"{CASE}/labels.npz",
    output:
        f"{INC}/quality.json",
    log:
        f"{LOG}/{{inc}}/quality.log",
    priority: in_turn()
    group:
        f"{CHECKED}_{{case}}_{{inc}}"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=job_memory("check", f"{INC}/gradated.vtp"),
        runtime=job_minutes("check", f"{INC}/gradated.vtp"),
    params:
        costs=f"{BENCHMARK}/{{inc}}/quality.tsv",
        code=CAMPAIGN.code("check"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh check {input.volume:q} --labels {input.labels:q} --meshing {input.meshing:q} --quality {output:q}"
        " > {log:q} 2>&1"
