rule remesh:
    input:
        f"{CASE}/labels.npz",
    output:
        f"{CASE}/remeshed.vtp",
    log:
        f"{LOG}/remeshed.log",
    priority: in_turn()
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=job_memory("remesh", f"{CASE}/labels.npz"),
        runtime=job_minutes("remesh", f"{CASE}/labels.npz"),
    params:
        costs=f"{BENCHMARK}/remeshed.tsv",
        options=lambda wildcards: CAMPAIGN.flags("remesh", wildcards.case),
        code=CAMPAIGN.code("remesh"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh remesh {input:q} {params.options} -o {output:q} > {log:q} 2>&1"


rule size:
    input:
        unpack(lambda wildcards: CAMPAIGN.crack(wildcards.case, wildcards.inc)),
        surface=f"{CASE}/remeshed.vtp",
        labels=f"{CASE}/labels.npz",
        files=given("size"),
    output:
        f"{INC}/sizing.npz",
    log:
        f"{LOG}/{{inc}}/sizing.log",
    priority: in_turn()
    group:
        "surface_{case}_{inc}"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=job_memory("size", f"{CASE}/remeshed.vtp"),
        runtime=job_minutes("size", f"{CASE}/remeshed.vtp"),
    params:
        costs=f"{BENCHMARK}/{{inc}}/sizing.tsv",
        options=lambda wildcards: CAMPAIGN.flags("sizing", wildcards.case),
        crack=lambda wildcards, input: command_flags({"crack": input.get("crack")}),
        content=content("size"),
        code=CAMPAIGN.code("size"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh size {input.surface:q} {params.crack} --labels {input.labels:q} {params.options}"
        " -o {output:q} > {log:q} 2>&1"


rule stitch:
    input:
        unpack(lambda wildcards: CAMPAIGN.crack(wildcards.case, wildcards.inc)),
        surface=f"{CASE}/remeshed.vtp",
        sizing=f"{INC}/sizing.npz",
    output:
        f"{INC}/surface.vtp",
    log:
        f"{LOG}/{{inc}}/surface.log",
    priority: in_turn()
    group:
        "surface_{case}_{inc}"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=job_memory("stitch", f"{CASE}/remeshed.vtp"),
        runtime=job_minutes("stitch", f"{CASE}/remeshed.vtp"),
    params:
        costs=f"{BENCHMARK}/{{inc}}/surface.tsv",
        options=lambda wildcards: CAMPAIGN.flags("stitch", wildcards.case),
        crack=lambda wildcards, input: command_flags({"crack": input.get("crack")}),
        code=CAMPAIGN.code("stitch"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh stitch {input.surface:q} {params.crack} --sizing {input.sizing:q} {params.options}"
        " -o {output:q} > {log:q} 2>&1"


rule gradate:
    input:
        unpack(lambda wildcards: CAMPAIGN.crack(wildcards.case, wildcards.inc)),
        surface=f"{INC}/surface.vtp",
        sizing=f"{INC}/sizing.npz",
    output:
        f"{INC}/gradated.vtp",
    log:
        f"{LOG}/{{inc}}/gradated.log",
    priority: in_turn()
    group:
        "surface_{case}_{inc}"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=job_memory("gradate", f"{CASE}/remeshed.vtp"),
        runtime=job_minutes("gradate", f"{CASE}/remeshed.vtp"),
    params:
        costs=f"{BENCHMARK}/{{inc}}/gradated.tsv",
        options=lambda wildcards: CAMPAIGN.flags("gradate", wildcards.case),
        crack=lambda wildcards, input: command_flags({"crack": input.get("crack")}),
        code=CAMPAIGN.code("gradate"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh gradate {input.surface:q} {params.crack} --sizing {input.sizing:q} {params.options}"
        " -o {output:q} > {log:q} 2>&1"
