#!/bin/bash
# One part of a study of many motions in a SLURM job array. In a folder with the study:
#
#     mkdir -p logs
#     array=$(sbatch --parsable array.sh chart.toml chart.zarr 100)
#     sbatch --dependency=afterok:$array merge.sh chart.toml chart.zarr
#
# A part that was ended goes on where it stopped: sbatch --array=7,12 array.sh chart.toml chart.zarr 100
#
#SBATCH --job-name=percuss
#SBATCH --array=1-100
#SBATCH --cpus-per-task=1
#SBATCH --time=04:00:00
#SBATCH --output=logs/%A_%a.log
set -eu
STUDY=$1 STORE=$2 PARTS=$3
# Lines of progress go into the log; exec has percuss hear SIGTERM at the end of the time.
exec percuss run "$STUDY" --store "$STORE" --part "$SLURM_ARRAY_TASK_ID/$PARTS"
