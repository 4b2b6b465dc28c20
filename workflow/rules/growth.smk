# a checkpoint, because only its report says whether the crack goes on
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
    priority: in_turn(0.5)  # the next increment waits for it
    localrule: True
    conda:
        "../envs/craftmesh.yaml"
    params:
        costs=f"{BENCHMARK}/{{inc}}/growth.tsv",
        options=lambda wildcards: CAMPAIGN.grow_flags(wildcards.case),
        last=lambda wildcards, input: command_flags(
            {f"last_{key}": input.get(key) for key in ("base", "step")}
        ),
        code=CAMPAIGN.code("grow"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh grow {input.crack:q} {input.sif:q} {input.front:q} --volume {input.labels:q} {params.options}"
        " {params.last} -o {output.grown:q} --base {output.base:q} --step {output.step:q}"
        " --report {output.report:q} > {log:q} 2>&1"
