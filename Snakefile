# The workflow of this folder. Other folders take it in as a module: see the README, From any folder.
include: "workflow/Snakefile"


workflow.default_target = "all"  # which Snakemake does not take over from what is included
