"""Options that may be left out, as their help names them."""

from __future__ import annotations

from typing import Annotated

import tyro

Number = Annotated[float | None, tyro.conf.arg(metavar="FLOAT")]
Name = Annotated[str | None, tyro.conf.arg(metavar="NAME")]
