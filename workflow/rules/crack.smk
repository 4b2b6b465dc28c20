rule crack:
    input:
        unpack(lambda wildcards: CAMPAIGN.previous_crack(wildcards.case, wildcards.inc)),
        unpack(lambda wildcards: CAMPAIGN.crack_surface(wildcards.case, wildcards.inc)),
        labels=f"{CASE}/labels.npz",
        files=given("crack"),
    output:
        f"{INC}/crack.vtp",
    log:
        f"{LOG}/{{inc}}/crack.log",
    priority: in_turn()
    localrule: True
    conda:
        "../envs/craftmesh.yaml"
    params:
        costs=f"{BENCHMARK}/{{inc}}/crack.tsv",
        options=lambda wildcards: CAMPAIGN.crack_flags(wildcards.case, wildcards.inc),
        increment=lambda wildcards: int(wildcards.inc),
        others=lambda wildcards, input: command_flags(
            {key: input.get(key) for key in ("previous", "surface")}
        ),
        content=content("crack"),
        code=CAMPAIGN.code("crack"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh crack {input.labels:q} --increment {params.increment:q} {params.others} -o {output:q}"
        " {params.options} > {log:q} 2>&1"
