"""`python -m bodyschema` is the command `bodyschema`."""

from bodyschema.cli import main

if __name__ == "__main__":
    main()
