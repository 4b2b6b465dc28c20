rule crack:
    input:
        unpack(lambda wildcards: CAMPAIGN.previous_crack(wildcards.case, wildcards.inc)),
        labels=f"{CASE}/labels.npz",
        files=lambda wildcards: CAMPAIGN.crack_files(wildcards.case, wildcards.inc),
    output:
        f"{INC}/crack.vtp",
    log:
        f"{LOG}/{{inc}}/crack.log",
    benchmark:
        f"{BENCHMARK}/{{inc}}/crack.tsv"
    localrule: True
    conda:
        "../envs/craftmesh.yaml"
    params:
        options=lambda wildcards: CAMPAIGN.crack_flags(wildcards.case, wildcards.inc),
        increment=lambda wildcards: int(wildcards.inc),
        previous=lambda wildcards, input: command_flags({"previous": input.get("previous")}),
        code=CAMPAIGN.code("crack"),
    shell:
        "craftmesh crack {input.labels} --increment {params.increment} {params.previous} -o {output}"
        " {params.options} > {log} 2>&1"
