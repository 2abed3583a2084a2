"""Tables of the pages."""


def table(headings, rows, n_right=0):
    """Markdown; the last `n_right` columns are right-aligned."""
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in (headings, *rows)]
    lines.insert(1, "|" + "---|" * (len(headings) - n_right) + "---:|" * n_right)
    return "\n".join(lines) + "\n"
