rule tetrahedralize:
    input:
        unpack(lambda wildcards: CAMPAIGN.crack(wildcards.case, wildcards.inc)),
        surface=f"{INC}/gradated.vtp",
        islands=f"{CASE}/islands.json",
        sizes=CAMPAIGN.size_files(),
    output:
        f"{INC}/tets/{{part}}-of-{{parts}}.npz",
    log:
        f"{LOG}/{{inc}}/tets/{{part}}-of-{{parts}}.log",
    benchmark:
        f"{BENCHMARK}/{{inc}}/tets/{{part}}-of-{{parts}}.tsv"
    conda:
        "../envs/craftmesh.yaml"
    threads: 1
    resources:
        mem_mb=lambda wildcards, attempt: 8000 * attempt,
        runtime=120,
    params:
        options=CAMPAIGN.flags("tetrahedralize"),
        sizing=CAMPAIGN.flags("sizing"),
        front=lambda wildcards, input: command_flags({"front": input.get("crack")}),
        code=CAMPAIGN.code("tetrahedralize"),
    shell:
        "craftmesh tetrahedralize {input.surface} --islands {input.islands} {params.front} {params.sizing}"
        " {params.options} --chunk {wildcards.part}/{wildcards.parts} --workers {threads}"
        " -o {output} > {log} 2>&1"


rule assemble:
    input:
        unpack(lambda wildcards: CAMPAIGN.crack(wildcards.case, wildcards.inc)),
        surface=f"{INC}/gradated.vtp",
        sizes=CAMPAIGN.size_files(),
        chunks=expand(
            f"{INC}/tets/{{part}}-of-{CAMPAIGN.chunks}.npz",
            part=range(1, CAMPAIGN.chunks + 1),
            allow_missing=True,
        ),
    output:
        volume=f"{INC}/volume.vtu",
        front=f"{INC}/front.csv",
        meshing=f"{INC}/meshing.json",
    log:
        f"{LOG}/{{inc}}/volume.log",
    benchmark:
        f"{BENCHMARK}/{{inc}}/volume.tsv"
    group:
        "deck_{case}_{inc}"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: 8000 * attempt,
        runtime=lambda wildcards, attempt: 30 * 5 ** (attempt - 1),
    params:
        options=CAMPAIGN.flags("tetrahedralize"),
        sizing=CAMPAIGN.flags("sizing"),
        front=lambda wildcards, input: command_flags({"front": input.get("crack")}),
        code=CAMPAIGN.code("assemble"),
    shell:
        "craftmesh assemble {input.surface} {input.chunks} {params.front} {params.sizing} {params.options}"
        " -o {output.volume} --front-csv {output.front} --report {output.meshing} > {log} 2>&1"
