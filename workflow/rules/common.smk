def every_increment(pattern, growing=False):
    """Return the input function of `pattern` for every increment of every case, or of those that grow."""

    def growth(case, inc):
        return checkpoints.grow.get(case=case, inc=inc).output.report

    return lambda wildcards: CAMPAIGN.increments(pattern, growth, growing)
