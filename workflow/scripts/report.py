"""Calls `craftmesh report` with what is asked for in a file: a command line ends at 128 kB, 170 cases."""

import os
import shlex
import subprocess
import sys
import tempfile

job = snakemake  # noqa: F821  Snakemake puts it before these lines

with tempfile.NamedTemporaryFile("w", suffix=".json") as asked, open(job.log[0], "w") as log:
    asked.write(job.params.campaign)
    asked.flush()
    command = ["craftmesh", "report", job.params.results, "--campaign", asked.name]
    command += [*shlex.split(job.params.options), "-o", job.output.page]
    environment = os.environ | {"CRAFTMESH_COSTS": job.params.costs}
    sys.exit(subprocess.run(command, stdout=log, stderr=log, env=environment).returncode)
