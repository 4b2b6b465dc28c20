rule depict:
    input:
        unpack(lambda wildcards: CAMPAIGN.solution(wildcards.case, wildcards.inc)),
        volume=f"{INC}/volume.vtu",
    output:
        directory(f"{INC}/pictures"),
    log:
        f"{LOG}/{{inc}}/pictures.log",
    priority: in_turn(-0.5)  # only the report waits for it
    conda:
        "../envs/craftmesh.yaml"
    resources:
        mem_mb=job_memory("depict", f"{INC}/volume.vtu"),
        runtime=job_minutes("depict", f"{INC}/volume.vtu"),
    params:
        costs=f"{BENCHMARK}/{{inc}}/pictures.tsv",
        solution=lambda wildcards, input: command_flags({"solution": input.get("solution")}),
        units=lambda wildcards: CAMPAIGN.unit_flags(wildcards.case),
        code=CAMPAIGN.code("depict"),
    shell:
        "CRAFTMESH_COSTS={params.costs:q}"
        " craftmesh depict {input.volume:q} {params.solution} {params.units} -o {output:q} > {log:q} 2>&1"


rule report:
    input:
        files_of_each(CAMPAIGN.increments(), f"{INC}/quality.json", f"{INC}/pictures"),
        files_of_each(CAMPAIGN.increments(True, solved_for_report(CAMPAIGN)), f"{INC}/sif.csv"),
        files_of_each(CAMPAIGN.growths(), f"{INC}/growth.json"),
    output:
        page=f"{CAMPAIGN.results}/report.html",
        records=[f"{CAMPAIGN.results}/{case}/case.json" for case in CAMPAIGN.cases],
    log:
        f"{CAMPAIGN.results}/logs/report.log",
    localrule: True
    conda:
        "../envs/craftmesh.yaml"
    params:
        costs=f"{CAMPAIGN.results}/benchmarks/report.tsv",
        results=subpath(output.page, parent=True),
        # functions: in texts Snakemake takes braces for wildcards
        campaign=lambda wildcards: campaign_record(CAMPAIGN),
        options=lambda wildcards: command_flags(CAMPAIGN.config["report"]),
        code=CAMPAIGN.code("report"),
    script:
        "../scripts/report.py"
