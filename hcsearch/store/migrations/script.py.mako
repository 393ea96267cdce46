"""${message}: what it changes and why.

A migration is frozen: it spells out its DDL and imports nothing of hcsearch. The views are made anew after it.
"""

import sqlalchemy as sa
from alembic import op

revision = ${repr(up_revision)}
down_revision = ${repr(down_revision)}


def upgrade() -> None:
    """Upgrade from the revision before."""
    ${upgrades if upgrades else "pass"}
