"""measure.py REPORT COMMAND...: runs the command, writes its CPU seconds and largest resident MiB.

A program of its own, because Linux counts the memory of whoever starts a process as that process's:
this one is small.
"""

import os
import sys

if __name__ == "__main__":
    report, *command = sys.argv[1:]
    _, status, usage = os.wait4(os.spawnvp(os.P_NOWAIT, command[0], command), 0)
    with open(report, "w", encoding="ascii") as file:
        file.write(f"{usage.ru_utime + usage.ru_stime} {usage.ru_maxrss / 1024}\n")
    sys.exit(os.waitstatus_to_exitcode(status) != 0)
