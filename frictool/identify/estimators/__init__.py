"""The sliding parameters from records, one method a file; the table of them is `methods.py`."""
