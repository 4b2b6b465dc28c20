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


def every_increment(pattern, growing=False):
    """Return the input function of `pattern` for every increment of every case, or of those that grow."""

    return lambda wildcards: CAMPAIGN.increments(pattern, growth_report, growing)


def every_solved(pattern):
    """Return the input function of `pattern` for the increments of cases that grow or are solved for a sweep."""
    others = solved_for_report(CAMPAIGN)
    return lambda wildcards: CAMPAIGN.increments(pattern, growth_report, True, others)


def every_growth(pattern):
    """Return the input function of `pattern` for every increment after which a crack grows or stops."""
    return lambda wildcards: CAMPAIGN.growth_reports(pattern, growth_report)


def growth_report(case, inc):
    """Return the report of the growth after an increment; what follows waits for it."""
    return checkpoints.grow.get(case=case, inc=inc).output.report
