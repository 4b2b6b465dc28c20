def every_increment(pattern, growing=False):
    """Return the input function of `pattern` for every increment of every case, or of those that grow."""

    return lambda wildcards: CAMPAIGN.increments(pattern, growth_report, growing)


def every_growth(pattern):
    """Return the input function of `pattern` for every increment after which a crack grows or stops."""
    return lambda wildcards: CAMPAIGN.growth_reports(pattern, growth_report)


def growth_report(case, inc):
    """Return the report of the growth after an increment; what follows waits for it."""
    return checkpoints.grow.get(case=case, inc=inc).output.report
