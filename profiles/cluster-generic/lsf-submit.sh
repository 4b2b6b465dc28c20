#!/bin/sh
# Submits to LSF and prints the number of the job alone: `bsub` says "Job <123> is submitted to queue <normal>."
bsub -o .snakemake/%J.txt "$@" | sed -n 's/^Job <\([0-9]*\)>.*/\1/p'
