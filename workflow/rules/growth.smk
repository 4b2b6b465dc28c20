# a checkpoint, for the increments of a case that grows until it stops are known one by one
checkpoint grow:
    input:
        unpack(lambda wildcards: CAMPAIGN.last_step(wildcards.case, wildcards.inc)),
        crack=f"{INC}/crack.vtp",
        sif=f"{INC}/sif.csv",
        front=f"{INC}/front.csv",
        labels=f"{CASE}/labels.npz",
    output:
        grown=f"{INC}/grown.vtp",
        report=f"{INC}/growth.json",
        base=f"{INC}/base.vtp",
        step=f"{INC}/step.csv",
    log:
        f"{LOG}/{{inc}}/growth.log",
    benchmark:
        f"{BENCHMARK}/{{inc}}/growth.tsv"
    localrule: True
    conda:
        "../envs/craftmesh.yaml"
    params:
        options=lambda wildcards: CAMPAIGN.grow_flags(wildcards.case),
        until=lambda wildcards: CAMPAIGN.until_flag(wildcards.case),
        last=lambda wildcards, input: command_flags(
            {f"last_{key}": input.get(key) for key in ("base", "step")}
        ),
        code=CAMPAIGN.code("grow"),
    shell:
        "craftmesh grow {input.crack} {input.sif} {input.front} --volume {input.labels} {params.options} {params.until}"
        " {params.last} -o {output.grown} --base {output.base} --step {output.step} --report {output.report} > {log} 2>&1"
