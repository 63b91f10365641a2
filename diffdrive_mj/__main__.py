"""`python -m diffdrive_mj` is the program `diffdrive`."""

from diffdrive_mj.cli import main

if __name__ == "__main__":
    main()
