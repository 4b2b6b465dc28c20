rule report:
    input:
        quality=every_increment(f"{INC}/quality.json"),
        sif=every_increment(f"{INC}/sif.csv", growing=True),
    output:
        f"{CAMPAIGN.results}/report.html",
    log:
        f"{CAMPAIGN.results}/logs/report.log",
    benchmark:
        f"{CAMPAIGN.results}/benchmarks/report.tsv"
    localrule: True
    conda:
        "../envs/craftmesh.yaml"
    params:
        sif=lambda wildcards, input: command_flags({"sif": list(input.sif)}),
        code=CAMPAIGN.code("report"),
    shell:
        "craftmesh report {input.quality} {params.sif} -o {output} > {log} 2>&1"
