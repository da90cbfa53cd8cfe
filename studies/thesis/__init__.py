"""The thesis's tables and main figures made anew by frictool and compared with the published ones:
`make thesis`.

published.yaml  what the thesis prints, and how near ours has to be; nothing else is typed in
words.yaml      why a value differs, one for each that does
figures.yaml    what each figure of the thesis shows
parts/          a module a part of the thesis: product functions in, values and figures out
"""
