NODE = cluster_node(CAMPAIGN.config["node"])
# check runs beside inp in a job of two processors; where nodes have one it is a job of its own
CHECKED = "deck" if NODE.cpus != 1 else "quality"


def given(stage):
    """Return the input function of the user's files that a stage reads; `content` says when they change."""
    return lambda wildcards: [
        path if is_made(CAMPAIGN, path) else ancient(path)
        for path in given_files(CAMPAIGN, stage, **wildcards)
    ]


def content(stage):
    """Return the function of what is in the files that a stage reads; jobs, whose rules are not compared, skip it."""
    return lambda wildcards: content_of(CAMPAIGN, stage, **wildcards) if workflow.is_main_process else None


def job_memory(stage, file):
    """Return the function of the memory of a stage's job by the size of a file of its case or increment."""
    return lambda wildcards, attempt: memory_mb(stage, sizes_of(file.format(**wildcards)), attempt, NODE)


def job_minutes(stage, file):
    """Return the function of the minutes of a stage's job by the size of a file of its case or increment."""
    return lambda wildcards, attempt: minutes(stage, sizes_of(file.format(**wildcards)), attempt)


def in_turn(ahead=0.0):
    """Return the function of a job's priority: of earlier cases first, then of earlier increments, all above 0.

    ahead: above -0.9 and below 0.9, for jobs on which more or fewer jobs wait. Snakemake that takes numbers alone
    runs jobs in any order.
    """
    places = {case: place for place, case in enumerate(reversed(CAMPAIGN.cases), 1)}

    def priority(wildcards):
        case, increment = CAMPAIGN.cases[wildcards.case], int(wildcards.get("inc", 0))
        return places[case.name] + ahead - 0.1 * increment / case.increments

    return priority if hasattr(Rule, "expand_priority") else max(ahead, 0.0)


def files_of_each(increments, *patterns):
    """Return an input function of the files by `patterns` of each increment, a case and a name.

    Snakemake plans the files of a function once it knows all of them. Whether an increment is reached is known only
    after the growth before it. With functions of their own the first decks come early.
    """

    def files(case, inc):
        return lambda wildcards: (
            [pattern.format(case=case, inc=inc) for pattern in patterns]
            if CAMPAIGN.is_reached(case, inc, growth_report)
            else []
        )

    return [files(*increment) for increment in increments]


def growth_report(case, inc):
    """Return the report of the growth after an increment; what follows waits for it, but in a dry run."""
    if workflow.dryrun:
        return f"{INC}/growth.json".format(case=case, inc=inc)
    return checkpoints.grow.get(case=case, inc=inc).output.report
