"""The workflow's side: configuration, flags, files and digests of a campaign.

In come config.yaml and the sheet of cases (`sheet`, `cases`), out comes a `Campaign` that the rules ask
for files, flags and resources (`campaign`). The schema is made from the stages' option classes
(`config_schema`) and fills in defaults (`configuration`); what only a stage can tell is asked of it before
any job (`meaning`, `paths`). `effort` foretells elements, time and memory, `standing` tells where cases
are, and `digest` which code a result is of. `first_campaign` and `craftmesher` write configurations.
"""
