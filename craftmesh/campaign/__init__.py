"""Code for the workflow of a campaign: configuration, flags, files and digests.

`sheet` and `cases` read the case table; `campaign` checks it with config.yaml and returns a `Campaign`,
from which the workflow's rules get files, flags and resources. `config_schema` makes the JSON schema from
the stages' option classes, and `configuration` fills in its defaults. `option_checks` and `paths` make the
checks that need a stage, before any job. `job_resources` estimates elements, time and memory, `case_status`
reports the status of cases, and `digest` identifies code. `first_campaign` and `craftmesher` write
configurations.
"""
