rule remesh:
    input:
        f"{CASE}/labels.npz",
    output:
        f"{CASE}/remeshed.vtp",
    log:
        f"{LOG}/remeshed.log",
    benchmark:
        f"{BENCHMARK}/remeshed.tsv"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: 8000 * attempt,
        runtime=60,
    params:
        options=CAMPAIGN.flags("remesh"),
        code=CAMPAIGN.code("remesh"),
    shell:
        "craftmesh remesh {input} {params.options} -o {output} > {log} 2>&1"


rule stitch:
    input:
        unpack(lambda wildcards: CAMPAIGN.crack(wildcards.case, wildcards.inc)),
        surface=f"{CASE}/remeshed.vtp",
        sizes=CAMPAIGN.size_files(),
    output:
        f"{INC}/surface.vtp",
    log:
        f"{LOG}/{{inc}}/surface.log",
    benchmark:
        f"{BENCHMARK}/{{inc}}/surface.tsv"
    group:
        "surface_{case}_{inc}"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: 4000 * attempt,
        runtime=30,
    params:
        options=CAMPAIGN.flags("stitch"),
        sizing=CAMPAIGN.flags("sizing"),
        crack=lambda wildcards, input: command_flags({"crack": input.get("crack")}),
        code=CAMPAIGN.code("stitch"),
    shell:
        "craftmesh stitch {input.surface} {params.crack} {params.sizing} {params.options}"
        " -o {output} > {log} 2>&1"


rule gradate:
    input:
        unpack(lambda wildcards: CAMPAIGN.crack(wildcards.case, wildcards.inc)),
        surface=f"{INC}/surface.vtp",
        sizes=CAMPAIGN.size_files(),
    output:
        f"{INC}/gradated.vtp",
    log:
        f"{LOG}/{{inc}}/gradated.log",
    benchmark:
        f"{BENCHMARK}/{{inc}}/gradated.tsv"
    group:
        "surface_{case}_{inc}"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: 8000 * attempt,
        runtime=60,
    params:
        options=CAMPAIGN.flags("gradate"),
        sizing=CAMPAIGN.flags("sizing"),
        front=lambda wildcards, input: command_flags({"front": input.get("crack")}),
        code=CAMPAIGN.code("gradate"),
    shell:
        "craftmesh gradate {input.surface} {params.front} {params.sizing} {params.options}"
        " -o {output} > {log} 2>&1"
