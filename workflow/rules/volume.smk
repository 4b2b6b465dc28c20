rule tetrahedralize:
    input:
        surface=f"{INC}/gradated.vtp",
        islands=f"{CASE}/islands.json",
        sizing=f"{INC}/sizing.npz",
    output:
        f"{INC}/tets/{{part}}-of-{{parts}}.npz",
    log:
        f"{LOG}/{{inc}}/tets/{{part}}-of-{{parts}}.log",
    priority: in_turn()
    conda:
        "../envs/craftmesh.yaml"
    threads: NODE.workers
    resources:
        mem_mb=job_memory("tetrahedralize", f"{INC}/gradated.vtp"),
        runtime=job_minutes("tetrahedralize", f"{INC}/gradated.vtp"),
    params:
        costs=f"{BENCHMARK}/{{inc}}/tets/{{part}}-of-{{parts}}.tsv",
        options=lambda wildcards: CAMPAIGN.flags("tetrahedralize", wildcards.case),
        code=CAMPAIGN.code("tetrahedralize"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh tetrahedralize {input.surface:q} --islands {input.islands:q} --sizing {input.sizing:q}"
        " {params.options} --chunk {wildcards.part:q}/{wildcards.parts:q} --workers {threads:q}"
        " -o {output:q} > {log:q} 2>&1"


rule assemble:
    input:
        unpack(lambda wildcards: CAMPAIGN.crack(wildcards.case, wildcards.inc)),
        surface=f"{INC}/gradated.vtp",
        sizing=f"{INC}/sizing.npz",
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
    priority: in_turn()
    group:
        "deck_{case}_{inc}"
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=job_memory("assemble", f"{INC}/gradated.vtp"),
        runtime=job_minutes("assemble", f"{INC}/gradated.vtp"),
    params:
        costs=f"{BENCHMARK}/{{inc}}/volume.tsv",
        options=lambda wildcards: CAMPAIGN.flags("tetrahedralize", wildcards.case),
        crack=lambda wildcards, input: command_flags({"crack": input.get("crack")}),
        code=CAMPAIGN.code("assemble"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh assemble {input.surface:q} {input.chunks:q} {params.crack} --sizing {input.sizing:q}"
        " {params.options} -o {output.volume:q} --front-csv {output.front:q} --report {output.meshing:q} > {log:q} 2>&1"


# in the place of assemble, and of the stages before it, where the mesh before is reused
ruleorder: renew > assemble


rule renew:
    input:
        unpack(lambda wildcards: CAMPAIGN.mesh_before(wildcards.case, wildcards.inc)),
        surface=f"{CASE}/remeshed.vtp",
        crack=f"{INC}/crack.vtp",
        sizing=f"{INC}/sizing.npz",
        islands=f"{CASE}/islands.json",
    output:
        volume=f"{INC}/volume.vtu",
        front=f"{INC}/front.csv",
        meshing=f"{INC}/meshing.json",
        map=f"{INC}/map.npz",
    log:
        f"{LOG}/{{inc}}/renewed.log",
    wildcard_constraints:
        case=CAMPAIGN.renewed,
        inc=r"(?!000)\d{3}",
    priority: in_turn()
    group:
        "deck_{case}_{inc}"
    conda:
        "../envs/craftmesh.yaml"
    threads: NODE.workers
    resources:
        mem_mb=job_memory("renew", f"{CASE}/000/volume.vtu"),
        runtime=job_minutes("renew", f"{CASE}/000/volume.vtu"),
    params:
        costs=f"{BENCHMARK}/{{inc}}/renewed.tsv",
        options=lambda wildcards: CAMPAIGN.renew_flags(wildcards.case),
        before=lambda wildcards, input: command_flags({"map_before": input.get("map_before")}),
        code=CAMPAIGN.code("renew"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh renew {input.before:q} {input.surface:q} --crack {input.crack:q} --sizing {input.sizing:q}"
        " --sizing-before {input.sizing_before:q} {params.before} --islands {input.islands:q} {params.options}"
        " --workers {threads:q} -o {output.volume:q} --front-csv {output.front:q} --report {output.meshing:q}"
        " --map {output.map:q} > {log:q} 2>&1"
