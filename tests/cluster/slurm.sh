#!/usr/bin/env bash
# A Slurm of one node on this machine, for `make test-cluster`: as root, with Debian's packages slurm-wlm and
# munge. `slurm.sh start`, `slurm.sh stop`. It is refused where a Slurm is configured already.
set -euo pipefail

conf=/etc/slurm/slurm.conf
mark="# one node for the tests of puffer"

start() {
    for program in slurmctld slurmd munged; do
        command -v "$program" > /dev/null || { echo "slurm.sh: no $program: apt install slurm-wlm munge"; exit 1; }
    done
    if [ -e "$conf" ] && ! grep --quiet "$mark" "$conf"; then
        echo "slurm.sh: $conf is there: this machine has a Slurm of its own"
        exit 1
    fi
    host=$(hostname --short)
    mkdir -p /etc/slurm /var/spool/slurmctld /var/spool/slurmd /var/log/slurm /run/munge
    chown slurm: /var/spool/slurmctld /var/log/slurm
    chown munge: /run/munge
    cat > "$conf" <<EOF
$mark
ClusterName=one
SlurmctldHost=$host
SlurmUser=slurm
AuthType=auth/munge
StateSaveLocation=/var/spool/slurmctld
SlurmdSpoolDir=/var/spool/slurmd
SlurmctldLogFile=/var/log/slurm/slurmctld.log
SlurmdLogFile=/var/log/slurm/slurmd.log
SlurmctldPidFile=/run/slurmctld.pid
SlurmdPidFile=/run/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
NodeName=$host CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
EOF
    pgrep -x munged > /dev/null || runuser -u munge -- munged
    pgrep -x slurmctld > /dev/null || slurmctld
    pgrep -x slurmd > /dev/null || start_slurmd
    for _ in $(seq 30); do
        sinfo --noheader --format %t 2> /dev/null | grep --quiet idle && { sinfo; return; }
        sleep 1
    done
    echo "slurm.sh: no idle node after 30 s; see /var/log/slurm"
    exit 1
}

# Which of these a machine has depends on its kernel and on the version of Slurm.
start_slurmd() {
    for plugin in disabled cgroup/v1 cgroup/v2; do
        printf 'CgroupPlugin=%s\nIgnoreSystemd=yes\n' "$plugin" > /etc/slurm/cgroup.conf
        slurmd 2> /dev/null || continue
        sleep 2
        if pgrep -x slurmd > /dev/null; then return; fi
    done
    echo "slurm.sh: slurmd does not start; see /var/log/slurm/slurmd.log"
    exit 1
}

stop() {
    grep --quiet "$mark" "$conf" 2> /dev/null || { echo "slurm.sh: no Slurm of ours is configured"; exit 1; }
    pkill -x slurmd || true
    pkill -x slurmctld || true
    rm -f "$conf" /etc/slurm/cgroup.conf
}

case ${1:-} in
    start) start ;;
    stop) stop ;;
    *) echo "slurm.sh start | stop"; exit 2 ;;
esac
