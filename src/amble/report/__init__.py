"""Tables, figures, pages and result files."""

from amble.report.allocation import law_table
from amble.report.findings import contact_rows, contact_summary, paper_table
from amble.report.page import FigureFile, Page, page_text, solver_table, write_page
from amble.report.results import (
    contact_results,
    method_results,
    reduction_results,
    solver_results,
    write_results,
)
from amble.report.tables import Table

__all__ = [
    "FigureFile",
    "Page",
    "Table",
    "contact_results",
    "contact_rows",
    "contact_summary",
    "law_table",
    "method_results",
    "page_text",
    "paper_table",
    "reduction_results",
    "solver_results",
    "solver_table",
    "write_page",
    "write_results",
]
