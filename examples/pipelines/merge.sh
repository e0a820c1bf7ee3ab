#!/bin/bash
# The parts of a job array become one store, and the store NetCDF, CSV and pictures.
#
#SBATCH --job-name=percuss-merge
#SBATCH --cpus-per-task=1
#SBATCH --time=00:30:00
#SBATCH --output=logs/%j.log
set -eu
STUDY=$1 STORE=$2
percuss merge "$STORE"
percuss run "$STUDY" --store "$STORE"
