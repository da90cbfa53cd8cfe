"""Frame of the HTML pages, figures, tables and decimation, shared by all commands."""
