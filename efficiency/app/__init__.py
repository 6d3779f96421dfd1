"""The pair in a local browser (`mixed-ehl app`): start of the page and its address."""

import importlib.util
import secrets
import socket
import sys
from os import PathLike
from pathlib import Path

from ehl.common.errors import InputError


def serve_app(design: str | PathLike[str] | None = None, *, port: int = 8642, browser: bool = True) -> None:
    """Serve an interactive page of a pair on the loopback address until Ctrl-C.

    The address contains a random token, new at each start; without it the page does not open.

    Parameters
    ----------
    design : str or path, optional
        Design file listed with the shipped pairs: the only file the page opens.
    port : int
        1024 to 65535.
    browser : bool
        Open the page in the browser.

    Raises
    ------
    InputError
        The extra `app` is not installed, the design file cannot be used, or the port is in use.

    Examples
    --------
    >>> import efficiency
    >>> efficiency.serve_app(port=80)
    Traceback (most recent call last):
    ehl.common.errors.InputError: port = 80 cannot be used; allowed: 1024 to 65535.
    """
    if importlib.util.find_spec("nicegui") is None:
        raise InputError("app", None, "the extra `app`", 'Install it: python -m pip install "mixed-ehl[app]".')
    if not 1024 <= port <= 65535:
        raise InputError("port", port, "1024 to 65535")
    with socket.socket() as trial:
        if trial.connect_ex(("127.0.0.1", port)) == 0:
            raise InputError("port", port, "a free port", "Choose another one: --port 8643.")
    from efficiency.app.page import serve
    from efficiency.app.scene import Bench

    bench = Bench(None if design is None else Path(design))
    bench.start()  # refuses a file that cannot be used before the browser opens
    token = secrets.token_urlsafe(24)
    print(f"http://127.0.0.1:{port}/?token={token} (Ctrl-C ends it)", file=sys.stderr, flush=True)
    serve(bench, port, token, browser=browser)
