rule report:
    input:
        quality=every_increment(f"{INC}/quality.json"),
        sif=every_increment(f"{INC}/sif.csv", growing=True),
        growth=every_growth(f"{INC}/growth.json"),
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
        growing=lambda wildcards, input: command_flags(
            {"sif": list(input.sif), "growth": list(input.growth)}
        ),
        code=CAMPAIGN.code("report"),
    shell:
        "craftmesh report {input.quality} {params.growing} -o {output} > {log} 2>&1"
