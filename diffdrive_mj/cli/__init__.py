"""The program `diffdrive`."""

from diffdrive_mj.cli.program import main as main
