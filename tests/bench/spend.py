#!/usr/bin/env python3
"""Runs a command and writes what it took as JSON to descriptor 3: spend.py SECONDS COMMAND...

A process of its own: the peak memory that wait4 tells of a child is at least that of the process
it was forked from.
"""
import json
import mmap
import os
import resource
import sys
import time


def touch_memory(size=1 << 31):
    """A virtual machine gives pages back that nobody uses for two seconds, and the next program
    that wants them waits forty times as long for each: another one does that here first."""
    child = os.fork()
    if child == 0:
        try:
            with mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS) as room:
                room.madvise(mmap.MADV_HUGEPAGE)
                for place in range(0, size, mmap.PAGESIZE):
                    room[place] = 1
        finally:
            os._exit(0)
    os.wait4(child, 0)


def spend(seconds, command):
    """Exit code (negative: signal), processor time, wall time, peak memory in MB."""
    begin = time.monotonic()
    child = os.fork()
    if child == 0:
        try:
            resource.setrlimit(resource.RLIMIT_CPU, (seconds + 1, seconds + 3))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            os.execvp(command[0], command)
        finally:
            os._exit(127)
    _, status, usage = os.wait4(child, 0)
    return {'wall': time.monotonic() - begin, 'cpu': usage.ru_utime + usage.ru_stime,
            'memory': usage.ru_maxrss/1024, 'code': os.waitstatus_to_exitcode(status)}


if __name__ == '__main__':
    os.set_inheritable(3, False)
    touch_memory()
    os.write(3, json.dumps(spend(int(sys.argv[1]), sys.argv[2:])).encode())
