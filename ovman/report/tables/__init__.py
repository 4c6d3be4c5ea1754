"""The tables of the results: each is made of one file of metrics and written as csv, Markdown and LaTeX."""
