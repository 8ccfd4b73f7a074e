"""Write the reference pages, the scripts' types, and the figures of all pages."""

from core.sentences import static_folder
from tests.reference.figures import filled_pages
from tests.reference.pages import reference_pages

if __name__ == "__main__":
    for name, text in reference_pages().items():
        (static_folder() / "docs" / "reference" / name).write_text(text)
    for path, text in filled_pages().items():
        path.write_text(text, encoding="utf-8")
