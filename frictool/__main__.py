"""Entry point of `python -m frictool`, for use if the program `frictool` is not on the path."""

from frictool.cli.main import main

if __name__ == "__main__":
    main()
