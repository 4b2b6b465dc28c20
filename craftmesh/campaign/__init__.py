"""The workflow's side: configuration, flags, files and digests of a campaign."""
