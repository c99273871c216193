"""Shared memory that no kill can leave behind: the one file of addon/core that depends on the
operating system. Linux gives anonymous files (memfd); elsewhere `available()` is false and blobs
travel inside the frames."""

import mmap
import os


def available():
    return hasattr(os, "memfd_create")


class Memory:
    """`size` bytes that a child process may map by the descriptor `fd`. Pages cost nothing until
    they are touched."""

    def __init__(self, size, label):
        self.size = size
        # Sealing is allowed so that the child can forbid the memory to shrink under it.
        self.fd = os.memfd_create(label, os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.ftruncate(self.fd, size)
            self.map = mmap.mmap(self.fd, size)
        except (OSError, ValueError):
            os.close(self.fd)
            raise

    def release_pages(self):
        """Gives the pages back to the system; the bytes read as zero afterwards."""
        self.map.madvise(mmap.MADV_REMOVE)

    def close(self):
        if self.fd >= 0:
            os.close(self.fd)
            self.fd = -1
            try:
                self.map.close()
            except BufferError:
                pass  # somebody still looks at it: it goes with the last view
