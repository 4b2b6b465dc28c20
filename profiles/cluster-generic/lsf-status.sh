#!/bin/sh
# What became of the LSF job $1: running, success or failed. Queued and suspended jobs count as running.
bjobs "$1" | awk -v job="$1" '
    $1 == job { state = $3 }
    END { print state == "DONE" ? "success" : state == "EXIT" ? "failed" : "running" }'
