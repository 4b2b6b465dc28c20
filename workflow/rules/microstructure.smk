rule generate:
    input:
        given("generate"),
    output:
        f"{CASE}/generated.npz",
    log:
        f"{LOG}/generated.log",
    priority: in_turn()
    group:
        "volume_{case}"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=job_memory("generate", f"{CASE}/labels.npz"),
        runtime=job_minutes("generate", f"{CASE}/labels.npz"),
    params:
        costs=f"{BENCHMARK}/generated.tsv",
        options=lambda wildcards: CAMPAIGN.flags("generate", wildcards.case),
        content=content("generate"),
        code=CAMPAIGN.code("generate"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh generate {params.options} -o {output:q} > {log:q} 2>&1"


rule import_microstructure:
    input:
        lambda wildcards: CAMPAIGN.generated(wildcards.case),
        given("import_"),
    output:
        image=f"{CASE}/microstructure.vti",
        labels=f"{CASE}/labels.npz",
        islands=f"{CASE}/islands.json",
        report=f"{CASE}/import.json",
    log:
        f"{LOG}/microstructure.log",
    priority: in_turn()
    group:
        "volume_{case}"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=job_memory("import_microstructure", f"{CASE}/labels.npz"),
        runtime=job_minutes("import_microstructure", f"{CASE}/labels.npz"),
    params:
        costs=f"{BENCHMARK}/microstructure.tsv",
        options=lambda wildcards: CAMPAIGN.import_flags(wildcards.case),
        content=content("import_"),
        code=CAMPAIGN.code("import_"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh import {input:q} {params.options} --image {output.image:q} --labels {output.labels:q}"
        " --islands {output.islands:q} --report {output.report:q} > {log:q} 2>&1"
