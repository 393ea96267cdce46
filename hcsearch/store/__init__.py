"""The database: schema and upgrades, recording of work, and queries. Only this package uses SQLAlchemy and Alembic.

Names are resolved on first use, so that importing `hcsearch.store.columns` (for --help) does not load SQLAlchemy.
"""

from hcsearch.system.lazy import lazy_importer

__getattr__ = lazy_importer(__name__)
