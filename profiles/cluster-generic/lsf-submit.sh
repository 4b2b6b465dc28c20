#!/bin/sh
# Submits the script $4 to LSF for $1 processors of one host, $2 MB and $3 minutes, and prints the number of the job
# alone: `bsub` says "Job <123> is submitted to queue <normal>." Where a site reserves memory by the slot, not the
# host, it is to be divided by $1.
mkdir -p .snakemake/cluster
bsub -o .snakemake/cluster/%J.txt -n "$1" -M "$2MB" -W "$3" -R "span[hosts=1] rusage[mem=$2MB]" "$4" |
    sed -n 's/^Job <\([0-9]*\)>.*/\1/p'
