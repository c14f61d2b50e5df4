"""The report as a PDF of A4 pages, from the same HTML that a browser shows: by WeasyPrint, the extra [pdf]."""

from __future__ import annotations

import logging

from rover.errors import BadInput

FILE = "report.pdf"
WANTED = "a PDF takes the extra [pdf] (make setup-pdf, or pip install 'rover[pdf]') and the system's library Pango"


def require_pdf() -> None:
    """Raises BadInput, before anything is driven, where no PDF can be made."""
    from PIL import ImageFile

    # It tells Pillow to take pictures that end early, for the whole process: a map must not.
    strict = ImageFile.LOAD_TRUNCATED_IMAGES
    try:
        import weasyprint  # noqa: F401
    except (ImportError, OSError):  # OSError: without Pango
        raise BadInput(WANTED) from None
    finally:
        ImageFile.LOAD_TRUNCATED_IMAGES = strict


def report_pdf(html: str) -> bytes:
    """The same document gives the same bytes. Nothing that the document does not hold is fetched. Raises BadInput."""
    require_pdf()
    import weasyprint
    from weasyprint.urls import URLFetcher

    # It tells of every rule that is meant for screens.
    logging.getLogger("weasyprint").setLevel(logging.CRITICAL)
    logging.getLogger("fontTools").setLevel(logging.CRITICAL)
    content: bytes = weasyprint.HTML(string=html, url_fetcher=URLFetcher(allowed_protocols=("data",))).write_pdf()
    return content

