# a checkpoint, for the increments of a case that grows until it stops are known one by one
checkpoint grow:
    input:
        crack=f"{INC}/crack.vtp",
        sif=f"{INC}/sif.csv",
        front=f"{INC}/front.csv",
        labels=f"{CASE}/labels.npz",
    output:
        grown=f"{INC}/grown.vtp",
        report=f"{INC}/growth.json",
    log:
        f"{LOG}/{{inc}}/growth.log",
    benchmark:
        f"{BENCHMARK}/{{inc}}/growth.tsv"
    localrule: True
    conda:
        "../envs/craftmesh.yaml"
    params:
        options=lambda wildcards: CAMPAIGN.smoothing_flags(wildcards.case),
        until=lambda wildcards: CAMPAIGN.until_flag(wildcards.case),
        code=CAMPAIGN.code("grow"),
    shell:
        "craftmesh grow {input.crack} {input.sif} {input.front} --volume {input.labels} {params.options} {params.until}"
        " -o {output.grown} --report {output.report} > {log} 2>&1"
