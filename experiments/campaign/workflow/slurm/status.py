#!/usr/bin/python3
"""Says whether a job of Slurm is running, was a success or failed, as Snakemake 7 asks for it."""

import subprocess
import sys
import time

RUNNING = {"PENDING", "CONFIGURING", "COMPLETING", "RUNNING", "SUSPENDED", "REQUEUED", "RESIZING", "STOPPED", "SIGNALING", "STAGE_OUT"}


def state_of(job):
    """The job's state by the controller, or by the accounting for one that the controller has forgotten; None if neither knows it."""
    shown = subprocess.run(["scontrol", "--oneliner", "show", "job", job], capture_output=True, text=True, check=False).stdout
    for word in shown.split():
        if word.startswith("JobState="):
            return word.removeprefix("JobState=")
    shown = subprocess.run(["sacct", "--noheader", "--parsable2", "--allocations", "--format=State", "--jobs", job], capture_output=True, text=True, check=False).stdout
    return shown.split()[0] if shown.split() else None


def main():
    for attempt in range(5):
        state = state_of(sys.argv[1])
        if state is not None:
            break
        time.sleep(1 + attempt)
    print("running" if state in RUNNING else "success" if state == "COMPLETED" else "failed")


if __name__ == "__main__":
    main()
