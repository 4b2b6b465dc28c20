# The workflow of this folder, taken in as any other folder may take it in.
module craftmesh:
    snakefile:
        "workflow/Snakefile"
    config:
        config


use rule * from craftmesh
