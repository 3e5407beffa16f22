-- The script of a report: sorting and filtering of the table, comparison of images. Without it the page is whole, only still.
return [=[
"use strict";
(function(){
const $=(s,e)=>(e||document).querySelector(s),$$=(s,e)=>Array.from((e||document).querySelectorAll(s));
// ---- the table: a click or Enter on a head sorts by it ----
const table=$("#points");
if(table){
  const body=table.tBodies[0],rows=Array.from(body.rows),said=$("#said");
  const value=(row,i)=>{const c=row.cells[i],v=c.dataset.v;return v===undefined?c.textContent.trim():v===""?NaN:Number(v)};
  const order=(a,b)=>{
    if(typeof a==="number"&&typeof b==="number"){const x=a!==a,y=b!==b;return x||y?x-y:a-b}
    return String(a).localeCompare(String(b),undefined,{numeric:true});
  };
  $$("thead th[aria-sort]",table).forEach(th=>{
    const i=th.cellIndex;
    $("button",th).addEventListener("click",()=>{
      const down=th.getAttribute("aria-sort")==="ascending",sign=down?-1:1;
      const keyed=rows.map((row,k)=>({row,k,v:value(row,i)}));
      keyed.sort((a,b)=>{
        const missing=(a.v!==a.v)-(b.v!==b.v); // what has no value stays below
        return missing||sign*order(a.v,b.v)||a.k-b.k;
      });
      $$("thead th[aria-sort]",table).forEach(o=>o.setAttribute("aria-sort",o===th?(down?"descending":"ascending"):"none"));
      const all=document.createDocumentFragment();
      keyed.forEach(e=>all.appendChild(e.row));
      body.appendChild(all);
      said.textContent="Sorted by "+th.dataset.name+(down?", descending":", ascending");
    });
  });
  const all=$("#all");
  if(all){
    $("#alllabel").hidden=false;table.classList.add("few");
    all.addEventListener("change",()=>table.classList.toggle("few",!all.checked));
  }
  const filter=$("#filter");
  const words=rows.map(r=>r.textContent.toLowerCase());
  const shown=$("#shown");
  filter.addEventListener("input",()=>{
    const parts=filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    let n=0;
    rows.forEach((r,k)=>{const ok=parts.every(p=>words[k].includes(p));r.hidden=!ok;n+=ok});
    shown.textContent=parts.length?n+" of "+rows.length+" points":"";
  });
}
addEventListener("beforeprint",()=>$$("img[loading]").forEach(i=>{i.loading="eager"}));
// ---- images: two at a time ----
const box=$("#compare");
if(box){
  box.hidden=false;
  const a=$("#a"),b=$("#b"),slide=$("#slide"),gain=$("#gain"),stage=$("#stage");
  const items=$$(".gallery li[data-src]").map(li=>({src:li.dataset.src,name:li.dataset.name,w:+li.dataset.w||0,
    map:li.dataset.map,mean:li.dataset.mean}));
  items.forEach((it,i)=>[a,b].forEach(s=>s.add(new Option(it.name,i))));
  a.value=0;b.value=Math.min(items.length-1,Number(box.dataset.second)||1);
  const image=(it,cls)=>{const m=new Image();m.src=it.src;m.alt=it.name;m.className=cls+(it.w&&it.w<=160?" small":"");m.draggable=false;return m};
  const corner=(it,side)=>{const d=document.createElement("div");d.className="corner "+side;d.textContent=it.name;return d};
  const mode=()=>$("input[name=mode]:checked").value;
  let pane,top,divider;
  const place=()=>{
    if(!divider)return;
    const v=Number(slide.value);
    top.style.clipPath="inset(0 0 0 "+v+"%)";divider.style.left="calc("+v+"% - 1px)";
    slide.setAttribute("aria-valuetext",v+"% of A");
  };
  const bright=()=>{if(mode()==="difference"&&pane)pane.style.filter="brightness("+gain.value+")";$("#gainvalue").textContent="\u00d7"+gain.value};
  const draw=()=>{
    const m=mode(),A=items[a.value],map={src:A.map,name:A.map?"FLIP "+A.mean:"it has no reference: nothing to show",w:A.w};
    const B=m==="flip"?map:items[b.value],slides=m==="slide"||m==="flip";
    stage.textContent="";stage.className="stage"+(m==="side"?" side":"");top=divider=null;
    $("#slidelabel").hidden=!slides;$("#b").disabled=m==="flip";$("#gainlabel").hidden=m!=="difference";
    if(m==="side"){
      [[A,"a"],[B,"b"]].forEach(([it,s])=>{pane=document.createElement("div");pane.className="pane";pane.append(image(it,""),corner(it,s));
        stage.append(pane)});
      return;
    }
    pane=document.createElement("div");pane.className="pane "+(slides?"slide":m);
    pane.append(image(A,""));
    if(m!=="flip"||A.map){top=image(B,"over-image");pane.append(top)}
    if(slides&&top){divider=document.createElement("div");divider.className="divider";pane.append(divider)}
    if(slides)pane.append(corner(A,"a"),corner(B,"b"));
    stage.append(pane);
    place();bright();
    if(divider){
      const move=e=>{const r=pane.getBoundingClientRect();slide.value=Math.max(0,Math.min(100,(e.clientX-r.left)/r.width*100));place()};
      pane.addEventListener("pointerdown",e=>{pane.setPointerCapture(e.pointerId);move(e);e.preventDefault()});
      pane.addEventListener("pointermove",e=>{if(e.buttons)move(e)});
    }
  };
  [a,b].forEach(s=>s.addEventListener("change",draw));
  $$("input[name=mode]").forEach(r=>r.addEventListener("change",draw));
  slide.addEventListener("input",place);gain.addEventListener("input",bright);
  $("#swap").addEventListener("click",()=>{const v=a.value;a.value=b.value;b.value=v;draw()});
  $$(".gallery li[data-src]").forEach((li,i)=>{
    const pick=$(".pick",li);pick.hidden=false;
    $$("button",pick).forEach(x=>x.addEventListener("click",()=>{(x.dataset.to==="a"?a:b).value=i;draw();box.scrollIntoView({block:"nearest"})}));
  });
  draw();
  // ---- more images than one wants at once ----
  const more=$("#more");
  if(more)more.addEventListener("click",()=>{
    $$(".gallery li[hidden]").slice(0,60).forEach(li=>{li.hidden=false});
    if(!$(".gallery li[hidden]"))more.hidden=true;
  });
  if(more){$$(".gallery li").slice(60).forEach(li=>{li.hidden=true});more.hidden=false}
}
})();
]=]
