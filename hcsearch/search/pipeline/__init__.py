"""The pipeline: runs stages whose results are missing or outdated, one transaction per batch.

Names are resolved on first use, so that counts load neither databases nor the judging of motions.
"""

from hcsearch.system.lazy import lazy_importer

__getattr__ = lazy_importer(__name__)
