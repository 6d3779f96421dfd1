"""Pictures of the gallery: figures that results draw, which pyplot does not know of."""

from __future__ import annotations

from typing import Any


def scraper(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the variable ``figure`` of an example, in the form that sphinx-gallery requires."""
    import matplotlib.pyplot as plt
    from sphinx_gallery.scrapers import figure_rst

    figure = block_vars["example_globals"].get("figure")
    if figure is None or plt.get_fignums():
        return ""
    path = next(block_vars["image_path_iterator"])
    figure.savefig(path, dpi=100)
    return str(figure_rst([path], gallery_conf["src_dir"]))


def _get_sg_image_scraper() -> Any:
    return scraper
