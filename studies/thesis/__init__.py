"""Reproduction of the thesis's tables and main figures, compared with the published ones.

    published.yaml  published values and tolerances; frictool computes all others
    words.yaml      reason for each value that differs
    figures.yaml    content of each figure of the thesis
    parts/          one module per part of the thesis, which returns values and figures

`make thesis` runs it.
"""
