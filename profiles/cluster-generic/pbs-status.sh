#!/bin/sh
# What became of the PBS job $1: running, success or failed. Queued and held jobs count as running.
qstat -x -f "$1" | awk -F' = ' '
    $1 ~ /job_state/ { state = $2 }
    $1 ~ /Exit_status/ { code = $2 }
    END { print state != "F" ? "running" : code == "0" ? "success" : "failed" }'
