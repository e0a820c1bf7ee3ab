"""The workbench: a page in the browser, or in a notebook, over the whole package."""
