rule report:
    input:
        CAMPAIGN.increments(f"{INC}/quality.json"),
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
        "craftmesh report {input} -o {output} > {log} 2>&1"
