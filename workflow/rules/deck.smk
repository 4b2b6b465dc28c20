rule inp:
    input:
        volume=f"{INC}/volume.vtu",
        labels=f"{CASE}/labels.npz",
    output:
        CAMPAIGN.deck_files(f"{INC}/model.inp"),
    log:
        f"{LOG}/{{inc}}/model.log",
    benchmark:
        f"{BENCHMARK}/{{inc}}/model.tsv"
    params:
        options=CAMPAIGN.flags("inp"),
        code=CAMPAIGN.code("inp"),
    resources:
        mem_mb=lambda wildcards, attempt: 8000 * attempt,
        runtime=30,
    group:
        "deck_{case}_{inc}"
    shell:
        "craftmesh inp {input.volume} --microstructure {input.labels} {params.options} -o {output[0]} > {log} 2>&1"


rule check:
    input:
        volume=f"{INC}/volume.vtu",
        labels=f"{CASE}/labels.npz",
    output:
        f"{INC}/quality.json",
    log:
        f"{LOG}/{{inc}}/quality.log",
    benchmark:
        f"{BENCHMARK}/{{inc}}/quality.tsv"
    params:
        code=CAMPAIGN.code("check"),
    resources:
        mem_mb=lambda wildcards, attempt: 8000 * attempt,
        runtime=30,
    group:
        "deck_{case}_{inc}"
    shell:
        "craftmesh check {input.volume} --labels {input.labels} --quality {output} > {log} 2>&1"
