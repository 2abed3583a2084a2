# Sourced by the trials after steps.sh: makes a minimal Debian with debootstrap in $bare and runs commands in it. Root only.
# shellcheck shell=bash disable=SC2154  # root and program are set by steps.sh, bare by the trial

marker=$bare/etc/vrda-clean-root # only a root made by this script is removed

# own_mounts ARGUMENT...: restarts the script in its own mount namespace, so that all mounts end with it.
own_mounts() {
  (($(id -u) == 0)) || fail 'not root, wanted root: debootstrap and chroot need it'
  command -v debootstrap >/dev/null || fail 'found no debootstrap, wanted it installed: apt-get install debootstrap'
  if [[ -z ${VRDA_TRIAL_INSIDE:-} ]]; then
    VRDA_TRIAL_INSIDE=1 exec unshare --mount --propagation private -- "$root/scripts/$program" "$@"
  fi
}

# apt_sources: bookworm mirrors of this machine's apt configuration, one per line.
apt_sources() {
  # shellcheck disable=SC2016  # apt's own variables
  apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' |
    grep -E ' bookworm(-updates|-security)? main$' | sort -u
}

# apt_settings: apt's proxy and date settings.
apt_settings() {
  apt-config dump --format '%F "%v";%n' | grep -iE '^Acquire::((http|https)::(Proxy|Timeout)|Check-Valid-Until|Check-Date)\b' || true
}

# npm_settings: registry, proxy and certificates of this machine's npm, without credentials. Certificates are copied,
# since the new root has none.
npm_settings() {
  local key value
  command -v npm >/dev/null || return 0
  for key in registry proxy https-proxy cafile; do
    value=$(npm config get "$key" 2>/dev/null)
    [[ $value != null && $value != *@* ]] || continue
    if [[ $key == cafile ]]; then
      install -D -m 644 "$value" "$bare/etc/vrda-trial-certificates.crt"
      value=/etc/vrda-trial-certificates.crt
    fi
    printf '%s=%s\n' "$key" "$value"
  done
}

# remove_bare: removes a root made by a trial; fails on any other folder.
remove_bare() {
  [[ -e $bare ]] || return 0
  [[ -e $marker ]] || fail "found $bare, wanted a folder made by this script or none"
  rm -rf --one-file-system "$bare"
}

# bootstrap SUITE [PACKAGE]: minimal Debian with apt and one additional package, from the first bookworm mirror of apt.
# Further packages can be installed only in bookworm.
bootstrap() {
  local mirror
  mirror=$(apt_sources | awk '$3 == "bookworm" { print $2; exit }')
  remove_bare
  mkdir -p "$bare/etc"
  touch "$marker" # first, so that an interrupted debootstrap can be removed
  http_proxy=$(apt-config dump --format '%v%n' Acquire::http::Proxy) \
    debootstrap --variant=minbase ${2:+--include="$2"} "$1" "$bare" "${mirror:-http://deb.debian.org/debian}"
  apt_sources >"$bare/etc/apt/sources.list"
  apt_settings >"$bare/etc/apt/apt.conf.d/90trial"
  npm_settings >"$bare/root/.npmrc"
  cp /etc/resolv.conf /etc/hosts "$bare/etc/"
}

# mount_system: /proc and /dev, which programs need.
mount_system() {
  mount -t proc proc "$bare/proc"
  mount --rbind /dev "$bare/dev"
}

unmount_system() { umount --recursive --lazy "$bare/dev" "$bare/proc"; }

# inside COMMAND...: runs it in the bare root as root, or as $inside_user, with a minimal environment.
inside() {
  env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=~ LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    chroot --userspec="${inside_user:-root:root}" "$bare" "$@" </dev/null
}

n_packages() { inside dpkg-query -W | wc -l; }
