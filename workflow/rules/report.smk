rule report:
    input:
        quality=every_increment(f"{INC}/quality.json"),
        intensities=every_increment(f"{INC}/sif.csv", growing=True),
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
        code=CAMPAIGN.code("report"),
    shell:
        "craftmesh report {input.quality} -o {output} > {log} 2>&1"
